# The workflow lives in workflow/; this file lets plain `snakemake` find it from the root.


include: "workflow/Snakefile"


# An included file sets no default target, hence this twin of its rule all.
rule default:
    input:
        rules.all.input,


localrules:
    default,
