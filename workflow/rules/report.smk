# The report of the study.


rule report:
    input:
        dataset=rules.dataset.output,
        figures=rules.figures.output,
        claims=rules.claims.output.json,
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
