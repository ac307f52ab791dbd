"""One released encoder per file: what its file holds, how its pixels are made, what it returns."""
