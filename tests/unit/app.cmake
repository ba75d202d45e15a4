downrange_test(unit_watch_board ${CMAKE_CURRENT_LIST_DIR}/watch_board_test.cpp LIBS downrange_dds downrange_stage downrange_text)
target_sources(unit_watch_board PRIVATE ${PROJECT_SOURCE_DIR}/src/app/downrange/board.cpp)
target_include_directories(unit_watch_board PRIVATE ${PROJECT_SOURCE_DIR}/src)
