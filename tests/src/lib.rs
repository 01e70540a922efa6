//! Nothing: the tests are in `tests/tests`, their programs in `tests/cases`.
