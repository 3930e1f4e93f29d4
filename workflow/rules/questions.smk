# Answers to the questions of the study: surrogates, sensitivities, calibrations.


rule questions:
    input:
        rules.dataset.output,
    output:
        PLAN.answer_files,
    log:
        f"{RESULTS}/logs/questions.log",
    benchmark:
        f"{RESULTS}/benchmarks/questions.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **PLAN.reader_resources,
    params:
        questions=as_written(PLAN.questions),
        code=room_code("surrogates", "observable"),
    shell:
        'python -m sim job questions "$TALUS_STUDY" > {log} 2>&1'
