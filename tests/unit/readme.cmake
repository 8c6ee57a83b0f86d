vacuform_test(readme_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/readme_test.cpp LINKS vacuform_api)
target_compile_definitions(readme_test PRIVATE VACUFORM_README="${PROJECT_SOURCE_DIR}/README.md")
