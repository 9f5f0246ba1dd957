#!/bin/sh
# The environment that wrote this package, which has driftform.
exec {{ python }} -c "from driftform.cli import main; main()" "$@"
