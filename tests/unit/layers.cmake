downrange_script_test(unit_layers layers_test.sh TIMEOUT 600 ARGS ${PROJECT_SOURCE_DIR})
downrange_script_test(planted_faults_test planted_faults_test.sh ARGS ${PROJECT_SOURCE_DIR})
