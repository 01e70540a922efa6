//! Weighted least squares on a few columns, by orthogonal columns (modified Gram–Schmidt; Björck,
//! *Numerical Methods for Least Squares Problems*, 1996, 2.4). Columns that add nothing to those before
//! them, that one row decides alone, or that so few rows cannot bear, are left out.

/// A column is left out if less than this part of it is its own: it adds nothing.
const OWN: f64 = 1e-5;

/// A column is left out if one row has more than this part of it: its slope would be that row's.
const MOST_OF_ONE: f64 = 0.25;

/// Rows for each column, at least.
const ROWS_A_COLUMN: usize = 8;

/// Of a residual at least this part is taken to be left.
const LEAST_LEFT: f64 = 0.2;

/// A regression on some columns.
#[derive(Clone, Debug)]
pub(super) struct Regression {
    /// The rows.
    rows: Vec<Vec<f64>>,
    /// Roots of the weights of rows.
    roots: Vec<f64>,
    /// Number of the columns that are used.
    used: Vec<usize>,
    /// Those columns, weighted, each orthogonal to those before it and of length 1.
    orthogonal: Vec<Vec<f64>>,
    /// How they come from the columns: above the diagonal the parts that were taken away, on it the lengths.
    triangle: Vec<Vec<f64>>,
}

/// Values, regressed.
pub(super) struct Fit {
    /// The slope of each column; 0 where it is left out.
    pub(super) slopes: Vec<f64>,
    /// The residual of each value.
    pub(super) residuals: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Regression {
    /// On these rows, all of one length, with these weights ≥ 0.
    pub(super) fn of(rows: Vec<&[f64]>, weights: &[f64]) -> Regression {
        let roots: Vec<f64> = weights.iter().map(|w| w.sqrt()).collect();
        let columns = rows.first().map_or(0, |row| row.len());
        let mut regression = Regression {
            used: Vec::new(),
            orthogonal: Vec::new(),
            triangle: Vec::new(),
            rows: rows.iter().map(|row| row.to_vec()).collect(),
            roots,
        };
        for column in 0..columns {
            if (regression.used.len() + 1) * ROWS_A_COLUMN > rows.len() {
                break;
            }
            regression.add(column);
        }
        regression
    }

    fn weighted(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let roots = self.roots.iter().enumerate();
        roots.map(|(i, root)| root * value(i)).collect()
    }

    fn add(&mut self, column: usize) {
        let mut rest = self.weighted(|i| self.rows[i][column]);
        let length = dot(&rest, &rest).sqrt();
        let parts = self.take_away(&mut rest);
        let own = dot(&rest, &rest).sqrt();
        let largest = rest.iter().fold(0.0, |most: f64, x| most.max(x * x));
        let one_has_it = largest > MOST_OF_ONE * own * own;
        if own <= OWN * length || !own.is_finite() || one_has_it {
            return;
        }
        rest.iter_mut().for_each(|x| *x /= own);
        self.used.push(column);
        self.orthogonal.push(rest);
        self.triangle.push(parts.into_iter().chain([own]).collect());
    }

    /// Takes away from a column what those so far explain of it; how much of each.
    fn take_away(&self, column: &mut [f64]) -> Vec<f64> {
        let take = |known: &Vec<f64>| {
            let part = dot(known, column);
            column
                .iter_mut()
                .zip(known)
                .for_each(|(x, k)| *x -= part * k);
            part
        };
        self.orthogonal.iter().map(take).collect()
    }

    /// The part of each row's residual that is left of it because the row itself has drawn the slopes its way:
    /// 1 less its leverage (MacKinnon and White 1985).
    pub(super) fn left(&self) -> Vec<f64> {
        let row = |i: usize| {
            let leverage: f64 = self.orthogonal.iter().map(|q| q[i] * q[i]).sum();
            (1.0 - leverage).max(LEAST_LEFT)
        };
        (0..self.rows.len()).map(row).collect()
    }

    /// Regresses values, one for each row.
    pub(super) fn fit(&self, values: &[f64]) -> Fit {
        let mut rest = self.weighted(|i| values[i]);
        let mut parts = self.take_away(&mut rest);
        for k in (0..parts.len()).rev() {
            parts[k] /= self.triangle[k][k];
            for above in 0..k {
                parts[above] -= parts[k] * self.triangle[k][above];
            }
        }
        let mut slopes = vec![0.0; self.rows.first().map_or(0, Vec::len)];
        for (&column, slope) in self.used.iter().zip(parts) {
            slopes[column] = slope;
        }
        let left = |(row, value): (&Vec<f64>, &f64)| value - dot(row, &slopes);
        let residuals = self.rows.iter().zip(values).map(left).collect();
        Fit { slopes, residuals }
    }
}
