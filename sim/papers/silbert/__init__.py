"""Silbert et al. (2001), spheres down a rough incline: what is claimed, and how it is judged."""

import talus

talus.paper(__name__)
