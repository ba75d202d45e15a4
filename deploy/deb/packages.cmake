# The Debian packages downrange, downrange-idl and downrange-dev, by CPack (tools/package).
set(DOWNRANGE_PACKAGE_REVISION 1 CACHE STRING "Debian revision: what stands behind the hyphen of the packages' version")
set(DOWNRANGE_MAINTAINER "Downrange maintainers <maintainers@downrange.invalid>" CACHE STRING
    "Maintainer of the packages: who is asked when they do not work")

set(here ${CMAKE_CURRENT_LIST_DIR})
set(made ${CMAKE_CURRENT_BINARY_DIR}/deb)
find_program(GZIP gzip REQUIRED)
function(compressed from to)
  execute_process(COMMAND ${GZIP} -9nc ${from} OUTPUT_FILE ${to} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# What Debian asks of each package: copyright and two changelogs; with it what lintian need not complain of, and why.
string(TIMESTAMP DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
foreach(component service idl core)
  string(REPLACE "service" "downrange" name ${component})
  string(REPLACE "idl" "downrange-idl" name ${name})
  string(REPLACE "core" "downrange-dev" name ${name})
  configure_file(${here}/changelog.in ${made}/${name}/changelog.Debian @ONLY)
  compressed(${made}/${name}/changelog.Debian ${made}/${name}/changelog.Debian.gz)
  compressed(${PROJECT_SOURCE_DIR}/CHANGELOG.md ${made}/${name}/changelog.gz)
  install(FILES ${here}/copyright ${made}/${name}/changelog.Debian.gz ${made}/${name}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT debian_${component} EXCLUDE_FROM_ALL)
  if(EXISTS ${here}/${name}.lintian-overrides)
    install(FILES ${here}/${name}.lintian-overrides DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME ${name}
            COMPONENT debian_${component} EXCLUDE_FROM_ALL)
  endif()
endforeach()

# Configuration that an upgrade keeps as its owner left it (deb/conffiles): an example range, to be replaced by one's own.
install(FILES ${PROJECT_SOURCE_DIR}/config/naro.toml DESTINATION /etc/downrange RENAME range.toml
        COMPONENT debian_service EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_SOURCE_DIR}/config/dds-qos.xml ${here}/downranged.env DESTINATION /etc/downrange
        COMPONENT debian_service EXCLUDE_FROM_ALL)
# Programs to begin one's own with.
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/downrange-dev/examples
        COMPONENT debian_core EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
                                                WORLD_EXECUTE)
set(CPACK_PACKAGE_CONTACT ${DOWNRANGE_MAINTAINER})
set(CPACK_PACKAGE_VENDOR Downrange)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENTS_ALL service debian_service idl debian_idl core debian_core)
foreach(component service idl core)
  string(TOUPPER CPACK_COMPONENT_${component}_GROUP group)
  set(${group} ${component})
  string(TOUPPER CPACK_COMPONENT_DEBIAN_${component}_GROUP group)
  set(${group} ${component})
endforeach()

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${DOWNRANGE_PACKAGE_REVISION})
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)

set(CPACK_DEBIAN_SERVICE_PACKAGE_NAME downrange)
set(CPACK_DEBIAN_SERVICE_PACKAGE_SECTION science)
set(CPACK_DEBIAN_SERVICE_DESCRIPTION "tracking service of a launch range
Radars send plots, telemetry stations relay the vehicle's own GPS, both over
DDS. Downrange finds each radar's bias while the vehicle flies, fuses the
corrected radars into one trajectory, and tells every antenna where to point,
before the vehicle gets there.

This package has the service downranged with its systemd units, the command
downrange (simulation, replay, report, operator's orders) and example ranges.")
set(CPACK_DEBIAN_SERVICE_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SERVICE_PACKAGE_DEPENDS "debconf (>= 0.5) | debconf-2.0, procps, systemd | systemd-sysusers, systemd | systemd-tmpfiles")
set(CPACK_DEBIAN_SERVICE_PACKAGE_SUGGESTS "bash-completion, chrony | time-daemon, nftables")
set(CPACK_DEBIAN_SERVICE_PACKAGE_CONTROL_EXTRA ${here}/conffiles ${here}/postinst ${here}/prerm ${here}/postrm ${here}/templates)

set(CPACK_DEBIAN_IDL_PACKAGE_NAME downrange-idl)
set(CPACK_DEBIAN_IDL_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_IDL_PACKAGE_SECTION science)
set(CPACK_DEBIAN_IDL_DESCRIPTION "types of a launch range's DDS topics and archives
What radars, telemetry stations, trackers and antennas of any vendor's DDS
generate their types from, to talk to Downrange (downrange.idl), and the
records of its archives (archive.proto).")

set(CPACK_DEBIAN_CORE_PACKAGE_NAME downrange-dev)
set(CPACK_DEBIAN_CORE_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CORE_DESCRIPTION "launch-range tracking as a C++ library
Geodesy, estimators and the tracking engine of Downrange for programs of
one's own: static libraries, headers, a CMake package, and examples.")
set(CPACK_DEBIAN_CORE_PACKAGE_DEPENDS "downrange-idl (>= ${PROJECT_VERSION}), libeigen3-dev (>= 3.4), libgeographiclib-dev")

set(CPACK_PRE_BUILD_SCRIPTS ${here}/strip.cmake)
include(CPack)
