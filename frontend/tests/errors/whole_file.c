this is not C at all, only text;
and so on ( until the end
