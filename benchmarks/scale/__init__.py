"""What a large study costs: beside its runs, which are copies of one, or with all of them."""
