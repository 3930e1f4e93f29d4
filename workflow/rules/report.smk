# The page that shows it all, and one on each point where the study asks for them.


if STUDY.pages:

    # All in one job, which leaves those as they are whose runs have not changed.
    rule pages:
        input:
            [run_file(point) for point in STUDY.points],
        output:
            update([f"{RESULTS}/pages/{point}.html" for point in STUDY.points]),
        log:
            f"{RESULTS}/logs/pages.log",
        benchmark:
            f"{RESULTS}/benchmarks/pages.tsv"
        conda:
            "../envs/talus.yaml"
        threads: max(1, min(len(STUDY.points), cores_here() or 2))
        resources:
            **READING,
        params:
            folder=subpath(output[0], parent=True),
            code=room("report"),
        shell:
            "python -m sim page {input:q} --output {params.folder} --report ../report.html"
            " --processes {threads} --code {params.code} > {log} 2>&1"


rule report:
    input:
        dataset=rules.dataset.output,
        figures=rules.figures.output,
        claims=rules.claims.output.json,
        pages=rules.pages.output if STUDY.pages else [],
    output:
        report(
            f"{RESULTS}/report.html",
            caption="../report/report.rst",
            category="Report",
        ),
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **READING,
    params:
        # No input: its path may hold braces, which are no wildcards, and must not matter.
        study=files_hash(STUDY.files),
        plugins=[str(one) for one in STUDY.plugins],
        code=room("report"),
    shell:
        'python -m sim report "$TALUS_STUDY" > {log} 2>&1'
