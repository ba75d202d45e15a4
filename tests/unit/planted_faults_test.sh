#!/bin/bash
# Each fault of tools/plant-faults still has its place in the sources. Whether the tests notice it: tools/plant-faults.
set -euo pipefail
"$1/tools/plant-faults" --places
