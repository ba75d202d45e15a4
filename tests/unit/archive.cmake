downrange_test(archive_record_test ${CMAKE_CURRENT_LIST_DIR}/archive_record_test.cpp
               LIBS downrange_archive downrange_archive_proto)
downrange_test(archive_mcap_test ${CMAKE_CURRENT_LIST_DIR}/archive_mcap_test.cpp LIBS downrange_archive)
downrange_test(archive_compression_test ${CMAKE_CURRENT_LIST_DIR}/archive_compression_test.cpp LIBS downrange_archive)
downrange_test(archive_replay_test ${CMAKE_CURRENT_LIST_DIR}/archive_replay_test.cpp LIBS downrange_archive)
foreach(part new_archive import import_advice import_kinds import_plausibility import_table import_text import_values)
  downrange_test(archive_${part}_test ${CMAKE_CURRENT_LIST_DIR}/archive_${part}_test.cpp LIBS downrange_archive)
endforeach()
