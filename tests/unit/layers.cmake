downrange_script_test(unit_layers layers_test.sh TIMEOUT 600 ARGS ${PROJECT_SOURCE_DIR})
