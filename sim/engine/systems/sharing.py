"""How the threads of one flow share its particles, and add up what each has put on the others'."""

import numpy as np

from sim.engine.compile import inlined, vectorised

#: Particles whose forces are cleared and collected together when several threads add to them.
GROUP = 64


@inlined
def clear(spheres, flow, share):
    """Set to zero what one thread may have added to: its own particles and those marked for it."""
    vectorised()
    rank, begin, end = share
    for d in range(3):
        for k in range(begin, end):
            i = np.uint64(k)
            spheres.force[rank, d, i] = 0.0
            spheres.moment[rank, d, i] = 0.0
    for block in range(end // GROUP, flow.reached.shape[1]):
        if flow.reached[rank, block]:
            for k in range(max(end, block * GROUP), min((block + 1) * GROUP, spheres.radius.size)):
                i = np.uint64(k)
                for d in range(3):
                    spheres.force[rank, d, i] = 0.0
                    spheres.moment[rank, d, i] = 0.0


@inlined
def collect_forces(spheres, flow, share):
    """Add to a thread's forces on its own particles what the threads before it have added there."""
    vectorised()
    rank, begin, end = share
    for other in range(rank):
        for block in range(begin // GROUP, (end + GROUP - 1) // GROUP):
            if flow.reached[other, block]:
                for k in range(max(begin, block * GROUP), min((block + 1) * GROUP, end)):
                    i = np.uint64(k)
                    for d in range(3):
                        spheres.force[rank, d, i] += spheres.force[other, d, i]
                        spheres.moment[rank, d, i] += spheres.moment[other, d, i]


@inlined
def share_out(pairs, flow):
    """Give each thread a range of first particles with the same number of pairs."""
    threads, particles = flow.border.size - 1, pairs.start.size - 1
    for rank in range(1, threads):
        border = flow.border[rank - 1]
        while pairs.start[border] * threads < pairs.start[particles] * rank:
            border += 1
        flow.border[rank] = border


@inlined
def mark_reached(pairs, flow, rank):
    """Mark the groups of other threads' particles that the pairs of one thread reach."""
    begin, end = flow.border[rank], flow.border[rank + 1]
    for block in range(flow.reached.shape[1]):
        flow.reached[rank, block] = False
    for p in range(pairs.start[begin], pairs.start[end]):
        j = pairs.second[np.uint64(p)]
        if j >= end:
            flow.reached[rank, j // GROUP] = True
