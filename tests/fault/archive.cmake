downrange_test(archive_fault_test ${CMAKE_CURRENT_LIST_DIR}/archive_fault_test.cpp LIBS downrange_archive)
target_include_directories(archive_fault_test PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../unit)
