"""The bar below the board: learning curve and schedule of one run along one axis."""
