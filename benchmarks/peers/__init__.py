"""Other programs doing the same work, each used as its authors recommend; a file a program."""
