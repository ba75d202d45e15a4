downrange_test(unit_watch_board ${CMAKE_CURRENT_LIST_DIR}/watch_board_test.cpp LIBS downrange_dds downrange_stage downrange_text)
target_sources(unit_watch_board PRIVATE ${PROJECT_SOURCE_DIR}/src/app/downrange/board.cpp
                                        ${PROJECT_SOURCE_DIR}/src/app/downrange/impact_lines.cpp)
target_include_directories(unit_watch_board PRIVATE ${PROJECT_SOURCE_DIR}/src)

# Of what DDS carries these see the plain structs only.
downrange_test(unit_node_answers ${CMAKE_CURRENT_LIST_DIR}/node_answers_test.cpp LIBS downrange_stage downrange_text)
target_sources(unit_node_answers PRIVATE ${PROJECT_SOURCE_DIR}/src/app/downrange/node_answers.cpp)
target_include_directories(unit_node_answers PRIVATE ${PROJECT_SOURCE_DIR}/src)

find_package(nlohmann_json REQUIRED)
downrange_test(unit_preflight ${CMAKE_CURRENT_LIST_DIR}/preflight_test.cpp LIBS downrange_stage downrange_text nlohmann_json::nlohmann_json)
target_sources(unit_preflight PRIVATE ${PROJECT_SOURCE_DIR}/src/app/downrange/preflight.cpp
                                      ${PROJECT_SOURCE_DIR}/src/app/downrange/preflight_text.cpp)
target_include_directories(unit_preflight PRIVATE ${PROJECT_SOURCE_DIR}/src)
