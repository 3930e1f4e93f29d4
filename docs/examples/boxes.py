"""A kind of plot: a box per point, of the replicates of any number."""

from matplotlib.figure import Figure

import talus
from talus.figures.plot import observable_label, parameter_label, replicate_values
from talus.study.plottable import numbers


def notes(data):
    return ["Boxes: quartiles of the replicates, whiskers: all of them."]


@talus.plot_kind("boxes", like="distribution", notes=notes)
def boxes(data):
    along, shown = data.spec.axes[0], numbers(data.spec.system)[data.spec.show]
    figure = Figure(figsize=(5.6, 3.9), layout="constrained")
    axes = figure.add_subplot()
    labels = [f"{value:g}" for value in data.rows[along]]
    axes.boxplot(replicate_values(data, shown), tick_labels=labels, whis=(0, 100))
    axes.set_xlabel(parameter_label(data.spec.system, along))
    axes.set_ylabel(observable_label(data, shown))
    return figure
