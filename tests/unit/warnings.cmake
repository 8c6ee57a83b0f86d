vacuform_test(warnings_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/warnings_test.cpp LINKS vacuform_warning)
target_compile_definitions(warnings_test PRIVATE VACUFORM_SOURCE="${PROJECT_SOURCE_DIR}")
