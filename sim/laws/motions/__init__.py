"""Motions of belt and plane that ship: a file each, which ends in the call that a plug-in makes."""
