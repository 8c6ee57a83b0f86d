vacuform_test(scan_test
  SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/scan_formats_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scan_skin_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scan_mold_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scan_plug_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scan_invariance_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scan_real_test.cpp
  LINKS vacuform_scan)
