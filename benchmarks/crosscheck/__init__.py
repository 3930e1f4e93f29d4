"""The same chute flows, with the same contact law, in Talus and in LAMMPS: do they agree?"""
