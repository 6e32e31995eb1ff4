"""What stands beside and below the board, one file for each panel."""
