downrange_test(archive_record_test ${CMAKE_CURRENT_LIST_DIR}/archive_record_test.cpp
               LIBS downrange_archive downrange_archive_proto)
downrange_test(archive_mcap_test ${CMAKE_CURRENT_LIST_DIR}/archive_mcap_test.cpp LIBS downrange_archive)
downrange_test(archive_compression_test ${CMAKE_CURRENT_LIST_DIR}/archive_compression_test.cpp LIBS downrange_archive)
downrange_test(archive_replay_test ${CMAKE_CURRENT_LIST_DIR}/archive_replay_test.cpp LIBS downrange_archive)
downrange_test(archive_import_test ${CMAKE_CURRENT_LIST_DIR}/archive_import_test.cpp LIBS downrange_archive)
