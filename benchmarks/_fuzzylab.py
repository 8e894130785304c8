"""The paper's own fuzzy library, in a process of its own with numpy < 2: `python _fuzzylab.py`, then requests.

Each request is one JSON line. `{"system": {...}}` builds a system; `{"inputs": [[...], ...]}` evaluates each input
with it, one call each, and answers the time per call and the outputs as they are returned.
"""

import json
import math
import sys
import time
import warnings

warnings.simplefilter("ignore")
KINDS = {"triangle": "trimf", "trapezoid": "trapmf"}


def build(told):
    import fuzzylab as fl

    fis = fl.mamfis()
    for side, add in (("inputs", fis.addInput), ("outputs", fis.addOutput)):
        for variable in told[side]:
            add([variable["low"], variable["high"]], Name=variable["name"])
            for name, kind, params in variable["sets"]:
                fis.addMF(variable["name"], KINDS[kind], params, Name=name)
    fis.addRule(told["rules"])
    return fis


def main():
    try:
        from importlib.metadata import version

        import fuzzylab as fl
        import numpy as np

        print(json.dumps({"version": f"{version('fuzzylab')}, numpy {np.__version__}"}), flush=True)
    except ImportError as error:
        print(json.dumps({"error": f"not there: {error}"}), flush=True)
        return
    fis = None
    for line in sys.stdin:
        request = json.loads(line)
        if "system" in request:
            fis = build(request["system"])
            print(json.dumps({}), flush=True)
            continue
        begin = time.perf_counter()
        rows = [fl.evalfis(fis, row)[0] for row in request["inputs"]]
        spent = time.perf_counter() - begin
        outputs = [[None if math.isnan(value) else float(value) for value in row] for row in rows]
        print(json.dumps({"seconds": spent / len(rows), "outputs": outputs}), flush=True)


if __name__ == "__main__":
    main()
