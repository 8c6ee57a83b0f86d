vacuform_test(api_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/settings_test.cpp ${CMAKE_CURRENT_LIST_DIR}/sha256_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/names_test.cpp
  LINKS vacuform_api)

vacuform_test(log_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/log_test.cpp LINKS vacuform_log)

vacuform_test(profiles_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/profiles_test.cpp LINKS vacuform_api)
target_compile_definitions(profiles_test PRIVATE VACUFORM_PROFILES="${PROJECT_SOURCE_DIR}/deploy/profiles")
