"""Silbert et al., Phys. Rev. E 64, 051302 (2001): flows of spheres down a rough plane."""

import talus

talus.paper(__name__)
