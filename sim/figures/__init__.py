"""From a dataset to pictures: how each kind of figure is drawn."""
