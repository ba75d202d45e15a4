downrange_test(text_test ${CMAKE_CURRENT_LIST_DIR}/text_test.cpp LIBS downrange_text)
