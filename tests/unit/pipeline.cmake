vacuform_test(pipeline_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/kept_stages_test.cpp LINKS vacuform_pipeline)
