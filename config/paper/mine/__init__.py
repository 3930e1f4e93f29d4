"""Author et al. (2000): flows of spheres down a plane."""

import talus

talus.paper(__name__)
