# One job draws one figure: an edit of its entry in the catalogue redraws it, one of the code all.


rule figure:
    input:
        rules.dataset.output,
    output:
        svg=report(
            f"{RESULTS}/figures/{{figure}}.svg",
            caption="../report/figure.rst",
            category="Figures",
            labels={"figure": "{figure}", "file": "picture"},
        ),
        csv=report(
            f"{RESULTS}/figures/{{figure}}.csv",
            caption="../report/data.rst",
            category="Figures",
            labels={"figure": "{figure}", "file": "data"},
        ),
        png=f"{RESULTS}/figures/{{figure}}.png",
        caption=f"{RESULTS}/figures/{{figure}}.caption.txt",
    log:
        f"{RESULTS}/logs/figures/{{figure}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/figures/{{figure}}.tsv"
    wildcard_constraints:
        figure="|".join(STILL) or "none",
    conda:
        "../envs/talus.yaml"
    params:
        folder=subpath(output.csv, parent=True),
        spec=lambda wildcards: repr(FIGURES[wildcards.figure]),
        code=room("figures"),
    shell:
        "python -m sim figure {wildcards.figure} {input} --output {params.folder} > {log} 2>&1"


use rule figure as animation with:
    output:
        gif=report(
            f"{RESULTS}/figures/{{figure}}.gif",
            caption="../report/figure.rst",
            category="Figures",
            labels={"figure": "{figure}", "file": "animation"},
        ),
        csv=f"{RESULTS}/figures/{{figure}}.csv",
        png=f"{RESULTS}/figures/{{figure}}.png",
        caption=f"{RESULTS}/figures/{{figure}}.caption.txt",
    wildcard_constraints:
        figure="|".join(ANIMATED) or "none",


rule figures:
    input:
        expand(rules.figure.output, figure=STILL),
        expand(rules.animation.output, figure=ANIMATED),
