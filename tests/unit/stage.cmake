downrange_test(stage_ingest_test ${CMAKE_CURRENT_LIST_DIR}/stage_ingest_test.cpp LIBS downrange_stage)
downrange_test(stage_slave_test ${CMAKE_CURRENT_LIST_DIR}/stage_slave_test.cpp LIBS downrange_stage)
downrange_test(stage_engine_test ${CMAKE_CURRENT_LIST_DIR}/stage_engine_test.cpp LIBS downrange_stage)
downrange_test(stage_source_monitor_test ${CMAKE_CURRENT_LIST_DIR}/stage_source_monitor_test.cpp LIBS downrange_stage)
