vacuform_test(api_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/settings_test.cpp ${CMAKE_CURRENT_LIST_DIR}/sha256_test.cpp
  LINKS vacuform_api)
