foreach(name dds_loopback_test dds_lockstep_test dds_mismatch_test)
  downrange_test(${name} ${CMAKE_CURRENT_LIST_DIR}/${name}.cpp LIBS downrange_dds downrange_dds_idl)
endforeach()

downrange_test(dds_ownership_test ${CMAKE_CURRENT_LIST_DIR}/dds_ownership_test.cpp LIBS downrange_dds)
add_executable(dds_owner_node ${CMAKE_CURRENT_LIST_DIR}/dds_owner_node.cpp)
target_link_libraries(dds_owner_node PRIVATE downrange_options downrange_dds)
add_dependencies(dds_ownership_test dds_owner_node)
target_compile_definitions(dds_ownership_test PRIVATE OWNER_NODE="$<TARGET_FILE:dds_owner_node>")
downrange_test(dds_release_test ${CMAKE_CURRENT_LIST_DIR}/dds_release_test.cpp LIBS downrange_dds downrange_dds_idl)

# An outage, and who is heard again: not only with Fast DDS as the nodes have it, but as it comes.
add_executable(dds_outage_node ${CMAKE_CURRENT_LIST_DIR}/dds_outage_node.cpp)
target_link_libraries(dds_outage_node PRIVATE downrange_options downrange_dds)
add_executable(fast_range_peer ${CMAKE_CURRENT_LIST_DIR}/fast_range_peer.cpp)
target_link_libraries(fast_range_peer PRIVATE downrange_options downrange_dds_idl)
# The cases that failed before; all of them: dds_outage_test.sh FOLDER.
add_test(NAME dds_outage_test COMMAND ${CMAKE_CURRENT_LIST_DIR}/dds_outage_test.sh ${CMAKE_CURRENT_BINARY_DIR} link:7 link:12
                                      stop:7)
set_tests_properties(dds_outage_test PROPERTIES TIMEOUT 180 LABELS interop SKIP_RETURN_CODE 77)

# Another vendor's consumer, where that vendor's library is installed. Both generators name their files after the IDL file.
find_package(CycloneDDS QUIET)
find_program(IDLC idlc)
if(CycloneDDS_FOUND AND IDLC)
  set(cyclone_idl ${CMAKE_CURRENT_BINARY_DIR}/cyclone_idl)
  add_custom_command(
    OUTPUT ${cyclone_idl}/downrange.c ${cyclone_idl}/downrange.h
    COMMAND ${CMAKE_COMMAND} -E make_directory ${cyclone_idl}
    COMMAND ${IDLC} -l c -o ${cyclone_idl} ${PROJECT_SOURCE_DIR}/idl/downrange.idl
    DEPENDS ${PROJECT_SOURCE_DIR}/idl/downrange.idl)
  add_library(cyclone_idl STATIC ${cyclone_idl}/downrange.c)
  target_include_directories(cyclone_idl SYSTEM PUBLIC ${cyclone_idl})
  target_link_libraries(cyclone_idl PUBLIC CycloneDDS::ddsc PRIVATE downrange_hardening)
  add_executable(cyclone_slaving_client ${CMAKE_CURRENT_LIST_DIR}/cyclone_slaving_client.c)
  target_link_libraries(cyclone_slaving_client PRIVATE downrange_options cyclone_idl)
  add_executable(cyclone_radar_sender ${CMAKE_CURRENT_LIST_DIR}/cyclone_radar_sender.c)
  target_link_libraries(cyclone_radar_sender PRIVATE downrange_options cyclone_idl)

  downrange_test(dds_cyclone_test ${CMAKE_CURRENT_LIST_DIR}/dds_cyclone_test.cpp LIBS downrange_dds
                 downrange_dds_idl)
  foreach(name dds_cyclone_test dds_release_test)
    add_dependencies(${name} cyclone_slaving_client)
    target_compile_definitions(${name} PRIVATE CYCLONE_CLIENT="$<TARGET_FILE:cyclone_slaving_client>")
  endforeach()
else()
  message(STATUS "Cyclone DDS not found: the test with another vendor's consumer is left out")
endif()

# With Hamlib's own programs, where they are installed.
find_program(ROTCTLD rotctld)
find_program(ROTCTL rotctl)
if(ROTCTLD AND ROTCTL)
  downrange_script_test(interop_rotctl_test rotctl_test.sh TIMEOUT 180 TARGETS downrange downranged
                        ARGS $<TARGET_FILE_DIR:downrange> $<TARGET_FILE_DIR:downranged> ${PROJECT_SOURCE_DIR} 46)
else()
  message(STATUS "Hamlib's rotctld and rotctl not found: the test with them is left out")
endif()
