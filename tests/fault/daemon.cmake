foreach(part process flight)
  downrange_test(fault_daemon_${part} ${CMAKE_CURRENT_LIST_DIR}/daemon_${part}_test.cpp
                 LIBS downrange_dds downrange_archive downrange_config)
  target_compile_definitions(fault_daemon_${part} PRIVATE DOWNRANGED="$<TARGET_FILE:downranged>")
  add_dependencies(fault_daemon_${part} downranged)
endforeach()
downrange_test(fault_daemon_parts ${CMAKE_CURRENT_LIST_DIR}/daemon_parts_test.cpp LIBS downrange_service)
downrange_test(fault_service_wall_clock ${CMAKE_CURRENT_LIST_DIR}/service_wall_clock_test.cpp
               LIBS downrange_service downrange_archive)
