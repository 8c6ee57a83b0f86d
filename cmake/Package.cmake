# The Debian package: `deploy/package` builds it with `cpack -G DEB`. Its files beyond those of `cmake --install` are the
# component `package`: units, default settings, manual pages, deploy/setup and deploy/front, and what Debian asks for.
cmake_host_system_information(RESULT debian QUERY DISTRIB_INFO)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME vacuform)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
if(debian_ID STREQUAL "debian")  # each release of Debian has a package of its own, and an upgrade of Debian upgrades it
  string(APPEND CPACK_PACKAGE_VERSION "+deb${debian_VERSION_ID}")
endif()
set(CPACK_PACKAGE_CONTACT "Vacuform maintainers <maintainers@vacuform.invalid>")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Computes screen prints that come out as drawn when the printed sheet is vacuum
formed over a scanned head, for example the coils of an MRI receive array.
The package holds the command line, the HTTP service and its workers.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "ca-certificates, curl, fonts-dejavu-core, passwd")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "systemd-sysv")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "nginx")
set(scripts ${PROJECT_SOURCE_DIR}/deploy/debian)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${scripts}/conffiles ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_SET_DESTDIR ON)  # for /etc
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_CMAKE_PROJECTS "${PROJECT_BINARY_DIR};vacuform;ALL;/;${PROJECT_BINARY_DIR};vacuform;package;/")
include(CPack)

set(made ${PROJECT_BINARY_DIR}/package)
function(package_file file destination)
  install(FILES ${file} DESTINATION ${destination} COMPONENT package EXCLUDE_FROM_ALL)
endfunction()

set(BIN /usr/bin)
set(LISTEN 127.0.0.1:8080)
set(STATUS_LISTEN 127.0.0.1:8081)
set(FRONT "")
set(SERVER http://127.0.0.1:8080)
foreach(unit vacuform-server.service vacuform-worker@.service)
  configure_file(deploy/units/${unit} ${made}/${unit} @ONLY)
  package_file(${made}/${unit} lib/systemd/system)
endforeach()
foreach(settings server.json worker.json)
  configure_file(deploy/settings/${settings} ${made}/${settings} @ONLY)
  package_file(${made}/${settings} /etc/vacuform)
endforeach()

foreach(script setup front)
  install(PROGRAMS deploy/${script} DESTINATION lib/vacuform COMPONENT package EXCLUDE_FROM_ALL)
  file(CREATE_LINK ../lib/vacuform/${script} ${made}/vacuform-${script} SYMBOLIC)
  package_file(${made}/vacuform-${script} sbin)
endforeach()
package_file(deploy/machine.bash lib/vacuform)
package_file(deploy/nginx.conf lib/vacuform)

set(pages vacuform.1 vacuform-server.8 vacuform-worker.8 vacuform-setup.8 vacuform-front.8)
list(TRANSFORM pages PREPEND ${made}/ OUTPUT_VARIABLE page_files)
list(TRANSFORM page_files APPEND .gz)
add_custom_command(
  OUTPUT ${page_files}
  COMMAND ${CMAKE_COMMAND} -E env VACUFORM_BIN=$<TARGET_FILE_DIR:vacuform> ${PROJECT_SOURCE_DIR}/docs/generate --manuals ${made}
  DEPENDS vacuform vacuform-server vacuform-worker deploy/setup deploy/front docs/generate
  VERBATIM)
if(VACUFORM_TESTS)
  set(always ALL)
endif()
add_custom_target(manuals ${always} DEPENDS ${page_files})
foreach(page ${page_files})
  string(REGEX REPLACE ".*\\.([18])\\.gz" "share/man/man\\1" folder ${page})
  package_file(${page} ${folder})
endforeach()

package_file(deploy/debian/copyright ${CMAKE_INSTALL_DOCDIR})
package_file(CHANGELOG.md ${CMAKE_INSTALL_DOCDIR})
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file(deploy/debian/changelog ${made}/changelog @ONLY)
execute_process(COMMAND gzip -9nf ${made}/changelog COMMAND_ERROR_IS_FATAL ANY)
package_file(${made}/changelog.gz ${CMAKE_INSTALL_DOCDIR})
