foreach(name protocol turns link responder)
  downrange_test(unit_rotctl_${name} ${CMAKE_CURRENT_LIST_DIR}/rotctl_${name}_test.cpp LIBS downrange_rotctl downrange_stage)
endforeach()
