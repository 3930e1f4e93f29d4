# Verdicts on the claims of the papers.


rule claims:
    input:
        rules.dataset.output,
    output:
        json=f"{RESULTS}/claims.json",
        csv=report(
            f"{RESULTS}/claims.csv",
            caption="../report/claims.rst",
            category="Claims",
        ),
        verdicts=report(
            f"{RESULTS}/verdicts.csv",
            caption="../report/verdicts.rst",
            category="Claims",
        ),
    log:
        f"{RESULTS}/logs/claims.log",
    benchmark:
        f"{RESULTS}/benchmarks/claims.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **PLAN.reader_resources,
    params:
        numerics=numerics_mark(),
        code=room_code("papers", "judge"),
    shell:
        'python -m sim job claims "$TALUS_STUDY" > {log} 2>&1'
