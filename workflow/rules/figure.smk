# All figures of the study in one job. It leaves out those that are as they would be drawn, so that
# an edit of an entry of the catalogue redraws one figure, and one of the code all of them.


rule figures:
    input:
        rules.dataset.output,
    output:
        figure_files(),
    log:
        f"{RESULTS}/logs/figures.log",
    benchmark:
        f"{RESULTS}/benchmarks/figures.tsv"
    conda:
        "../envs/talus.yaml"
    threads: max(1, min(len(STUDY.figures), cores_here() or 2))
    resources:
        **READING | {"mem_mb": lambda wildcards, threads: threads * READING["mem_mb"]},
    params:
        folder=subpath(output[0], parent=True),
        names=list(STUDY.figures),
        entries=lambda wildcards: list(map(repr, STUDY.entries.values())),
        code=room("figures"),
    shell:
        "python -m sim figure {params.names} {input} --output {params.folder}"
        " --processes {threads} --code {params.code}"
        ' --study "$TALUS_STUDY" > {log} 2>&1'
