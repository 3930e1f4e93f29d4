# The report of the study, and a page on each point if the study has `pages: true`.


if STUDY.pages:

    # All pages in one job, which skips pages of unchanged runs.
    rule pages:
        input:
            lambda wildcards: run_files_of(STUDY.points),
        output:
            update([f"{RESULTS}/pages/{point}.html" for point in STUDY.points]),
        log:
            f"{RESULTS}/logs/pages.log",
        benchmark:
            f"{RESULTS}/benchmarks/pages.tsv"
        conda:
            "../envs/talus.yaml"
        threads: max(1, min(len(STUDY.points), local_cores() or 2))
        resources:
            **PLAN.reader_resources,
        params:
            folder=subpath(output[0], parent=True),
            code=room_code("report"),
        shell:
            "python -m sim job page {input:q} --output {params.folder} --report ../report.html"
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
        **PLAN.reader_resources,
    params:
        # The study file is no input: its path may contain braces and must not trigger a rerun.
        study=files_hash((*STUDY.files, *STUDY.data)),
        plugins=as_written([str(plugin) for plugin in STUDY.plugins]),
        code=room_code("report"),
    shell:
        'python -m sim job report "$TALUS_STUDY" > {log} 2>&1'
