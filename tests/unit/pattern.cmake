find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
pkg_check_modules(pattern_test_drawing REQUIRED IMPORTED_TARGET glib-2.0 cairo)

vacuform_test(pattern_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/pattern_test.cpp
  LINKS vacuform_pattern PNG::PNG JPEG::JPEG PkgConfig::pattern_test_drawing)

vacuform_test(drawing_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/drawing_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/drawing_parts_test.cpp
  LINKS vacuform_pattern PNG::PNG JPEG::JPEG PkgConfig::pattern_test_drawing)
