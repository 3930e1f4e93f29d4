# All figures of the study in one job, which skips figures that are up to date. So an edit of an
# entry of the catalogue redraws one figure, and an edit of the code redraws all of them.


rule figures:
    input:
        dataset=rules.dataset.output,
        answers=PLAN.answer_files,
    output:
        [
            update(
                report(
                    path,
                    caption=f"../report/{'data' if kind == 'data' else 'figure'}.rst",
                    category="Figures",
                    labels={"figure": name, "file": kind},
                )
                if kind
                else path
            )
            for path, name, kind in PLAN.figure_files
        ],
    log:
        f"{RESULTS}/logs/figures.log",
    benchmark:
        f"{RESULTS}/benchmarks/figures.tsv"
    conda:
        "../envs/talus.yaml"
    threads: max(1, min(len(STUDY.figures), local_cores() or 2))
    resources:
        **PLAN.reader_resources
        | {"mem_mb": lambda wildcards, threads: threads * PLAN.reader_resources["mem_mb"]},
    params:
        folder=subpath(output[0], parent=True),
        names=list(STUDY.figures),
        entries=as_written(list(map(repr, STUDY.entries.values()))),
        code=room_code("figures"),
    shell:
        "python -m sim figure {params.names} {input.dataset} --output {params.folder}"
        " --processes {threads} --code {params.code}"
        ' --study "$TALUS_STUDY" > {log} 2>&1'
