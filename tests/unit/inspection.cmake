find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(ZLIB REQUIRED)

vacuform_test(inspection_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/inspection_test.cpp
  LINKS vacuform_inspection PNG::PNG JPEG::JPEG ZLIB::ZLIB)

vacuform_test(coil_figures_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/coil_figures_test.cpp ${CMAKE_CURRENT_LIST_DIR}/shape_distance_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/coil_couplings_test.cpp
  LINKS vacuform_inspection)

vacuform_test(report_html_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/report_html_test.cpp
  LINKS vacuform_inspection PNG::PNG JPEG::JPEG ZLIB::ZLIB)

vacuform_test(mold_marks_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/mold_marks_test.cpp
  LINKS vacuform_inspection)
