"""What the particles meet besides each other: the plane of the chute, the belt, the obstacle."""
