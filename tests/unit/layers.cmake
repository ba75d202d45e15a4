downrange_script_test(unit_layers layers_test.sh ARGS ${PROJECT_SOURCE_DIR})
