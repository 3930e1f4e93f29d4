"""Contact laws: one file per law.

A law is a ``NamedTuple`` of its parameters and a body registered for the generic function of its
family. numba chooses the body by the tuple's type when a kernel is compiled, so particles, plane,
belt and obstacle share the law's code and no branch is left at run time.
"""
