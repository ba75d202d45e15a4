foreach(name dds_malformed_test dds_start_test)
  downrange_test(${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp LIBS downrange_dds downrange_dds_idl)
  set_tests_properties(${name} PROPERTIES LABELS "fault;interop")  # left out with the other DDS tests where they cannot run
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/interop)
endforeach()
