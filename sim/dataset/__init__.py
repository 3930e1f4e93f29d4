"""From run files to a dataset: statistics over replicates, measures, regimes, boundaries."""
