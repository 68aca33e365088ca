"""The peer of benches/uncertainty.rs: scikit-learn's homogeneity_score, which is U(L|R).

    python uncertainty.py LOCATION RESPONSE

Both files hold labels as 64-bit integers, least byte first. Says its version in a line; then for each line of input, a
number of times, it computes that often and answers with the seconds it took and the figure.
"""

import sys
import time

import numpy
import sklearn
from sklearn.metrics import homogeneity_score

location, response = (numpy.fromfile(file, dtype="<i8") for file in sys.argv[1:3])
print(f"scikit-learn {sklearn.__version__}, numpy {numpy.__version__}", flush=True)
for line in sys.stdin:
    began = time.perf_counter()
    for _ in range(int(line)):
        figure = homogeneity_score(labels_true=location, labels_pred=response)
    print(time.perf_counter() - began, repr(float(figure)), flush=True)
