downrange_test(dds_spdp_lease_test ${CMAKE_CURRENT_LIST_DIR}/dds_spdp_lease_test.cpp LIBS downrange_dds)
