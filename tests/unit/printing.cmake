find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(ZLIB REQUIRED)
pkg_check_modules(printing_test_drawing REQUIRED IMPORTED_TARGET glib-2.0 pugixml)

vacuform_test(printing_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/print_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/print_files_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/scan_lines_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/laid_ink_test.cpp
  LINKS vacuform_printing PNG::PNG JPEG::JPEG ZLIB::ZLIB PkgConfig::printing_test_drawing)

vacuform_test(vector_print_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/vector_print_test.cpp LINKS vacuform_printing)

vacuform_test(round_trip_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/round_trip_test.cpp
  LINKS vacuform_printing PNG::PNG JPEG::JPEG PkgConfig::printing_test_drawing)
