"""From a point to its run file: contact laws, motion, observables, and the runs themselves."""
