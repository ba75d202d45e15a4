downrange_test(dds_loopback_test ${CMAKE_CURRENT_LIST_DIR}/dds_loopback_test.cpp LIBS downrange_dds)
