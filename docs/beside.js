// Pages outside of the book, such as ../archdesc/FORMAT.md, are read as they are: mdbook takes every link to a page for one to its own.
for (const link of document.querySelectorAll('main a[href^="../"]'))
    link.setAttribute('href', link.getAttribute('href').replace(/\.html(?=#|$)/, '.md'));
