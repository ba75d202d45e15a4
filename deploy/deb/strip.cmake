# Before the packages are made: what neither running nor linking needs is taken out of programs and libraries.
file(GLOB_RECURSE libraries ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*.a)
file(GLOB programs ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/bin/*)
foreach(file IN LISTS libraries)
  execute_process(COMMAND strip --strip-debug --enable-deterministic-archives --remove-section=.comment ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
foreach(file IN LISTS programs)
  execute_process(COMMAND strip --strip-unneeded --remove-section=.comment --remove-section=.note ${file} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
